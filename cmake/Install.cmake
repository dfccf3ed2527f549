# Installing the library: headers, archive, exported target sfumato::sfumato, version file. Not the programs' parts.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set_target_properties(sfumato PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
install(TARGETS sfumato EXPORT sfumatoTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT library
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/sfumato DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sfumato)
install(EXPORT sfumatoTargets NAMESPACE sfumato:: DESTINATION ${package_dir} COMPONENT library)
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/package/sfumatoConfig.cmake CONTENT
"# The headers include vulkan/vulkan_core.h; nothing is linked.
find_path(SFUMATO_VULKAN_INCLUDE vulkan/vulkan_core.h)
if(NOT SFUMATO_VULKAN_INCLUDE)
  set(sfumato_FOUND FALSE)
  set(sfumato_NOT_FOUND_MESSAGE \"the Vulkan headers are missing (vulkan/vulkan_core.h)\")
  return()
endif()
include(\"\${CMAKE_CURRENT_LIST_DIR}/sfumatoTargets.cmake\")
target_include_directories(sfumato::sfumato SYSTEM INTERFACE \"\${SFUMATO_VULKAN_INCLUDE}\")
" ESCAPE_QUOTES @ONLY)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/sfumatoConfigVersion.cmake
  VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/sfumatoConfig.cmake ${PROJECT_BINARY_DIR}/package/sfumatoConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT library)
