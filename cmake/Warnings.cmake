# Warnings are errors in our own code, whichever target it is in; sanitizers are for all or none.
if(PROJECT_IS_TOP_LEVEL)
  # `VkXyzInfo info{VK_STRUCTURE_TYPE_XYZ}` zeroes the rest on purpose.
  add_compile_options(-Wall -Wextra -Wshadow -Wconversion -Werror -Wno-missing-field-initializers)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    add_compile_options(-Wno-restrict) # false alarms on std::string operator+, GCC bug 105651
  endif()
endif()
if(SFUMATO_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-Wno-maybe-uninitialized) # false alarms in <regex> under the sanitizers
  endif()
endif()
