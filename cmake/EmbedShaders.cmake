# sfumato_embed_shaders(target namespace include_dirs file.comp ...)
#
# One .comp, .vert or .frag holds all passes of an effect under `#ifdef PASS_name`; its first line names them: `// passes: velocity gather`.
# Each pass is compiled to SPIR-V, checked, and embedded as an array in `shaders/<file>.h`, which defines
# sfumato::shaders::<file>::<pass> of type sfumato::Shader.
find_program(GLSLC glslc REQUIRED)
find_program(SPIRV_VAL spirv-val REQUIRED)

function(sfumato_embed_shaders target)
  cmake_parse_arguments(EMBED "" "" "INCLUDES;SOURCES" ${ARGN})
  set(include_flags "")
  set(shader_headers "")
  foreach(directory IN LISTS EMBED_INCLUDES)
    list(APPEND include_flags -I ${directory})
    # Any change of a shared shader header rebuilds every shader: there are few of them.
    file(GLOB found CONFIGURE_DEPENDS ${directory}/*.glsl ${directory}/*_shared.h ${directory}/*.glsl.h)
    list(APPEND shader_headers ${found})
  endforeach()
  set(output_dir ${CMAKE_CURRENT_BINARY_DIR}/generated/shaders)
  foreach(source IN LISTS EMBED_SOURCES)
    get_filename_component(name ${source} NAME_WE)
    get_filename_component(file_name ${source} NAME)
    get_filename_component(source ${source} ABSOLUTE)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    file(STRINGS ${source} first_line LIMIT_COUNT 1)
    if(NOT first_line MATCHES "^// passes: (.+)$")
      message(FATAL_ERROR "${source}: the first line must be `// passes: ...`")
    endif()
    separate_arguments(passes UNIX_COMMAND "${CMAKE_MATCH_1}")
    set(arrays "")
    set(words "")
    foreach(pass IN LISTS passes)
      set(stem ${output_dir}/${name}.${pass})
      add_custom_command(
        OUTPUT ${stem}.inc
        COMMAND ${CMAKE_COMMAND} -E make_directory ${output_dir}
        COMMAND ${GLSLC} --target-env=vulkan1.1 -O -Werror -DPASS_${pass} ${include_flags} -o ${stem}.spv ${source}
        COMMAND ${SPIRV_VAL} --target-env vulkan1.1 ${stem}.spv
        COMMAND ${GLSLC} --target-env=vulkan1.1 -O -mfmt=num -DPASS_${pass} ${include_flags} -o ${stem}.inc ${source}
        DEPENDS ${source} ${shader_headers}
        COMMENT "Shader ${name}/${pass}"
        VERBATIM)
      list(APPEND words ${stem}.inc)
      string(APPEND arrays
        "inline constexpr uint32_t ${pass}_code[] = {\n#include \"${name}.${pass}.inc\"\n};\n"
        "inline constexpr Shader ${pass}{\"${name}/${pass}\", ${pass}_code};\n")
    endforeach()
    file(CONFIGURE OUTPUT ${output_dir}/${name}.h CONTENT
      "// Generated from ${file_name}.\n#pragma once\n#include \"sfumato/plan.h\"\nnamespace sfumato::shaders::${name} {\n${arrays}}\n")
    # A target a shader file: the arrays exist before anything that includes them is compiled.
    add_custom_target(${target}_${name}_shaders DEPENDS ${words})
    add_dependencies(${target} ${target}_${name}_shaders)
  endforeach()
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/generated)
endfunction()
