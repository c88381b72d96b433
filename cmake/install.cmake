# The program, the library, its headers, and what find_package(orasp) reads.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/orasp")
install(TARGETS orasp EXPORT orasp-targets FILE_SET HEADERS)
install(TARGETS orasp_cli)
foreach(module ${orasp_modules})
  if(TARGET ${module})
    install(TARGETS ${module} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/orasp")
  endif()
endforeach()
install(EXPORT orasp-targets NAMESPACE orasp:: DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/orasp-config-version.cmake" COMPATIBILITY SameMinorVersion)
install(
  FILES "${PROJECT_BINARY_DIR}/orasp-config-version.cmake" cmake/orasp-config.cmake cmake/Findmd.cmake
  DESTINATION "${package_dir}"
)

if(EXISTS "${PROJECT_SOURCE_DIR}/docs/orasp.1")
  install(FILES docs/orasp.1 DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
endif()
if(TARGET orasp_cli)  # its build writes the script
  install(FILES "${PROJECT_BINARY_DIR}/cli/orasp.bash" DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" RENAME orasp)
endif()
if(EXISTS "${PROJECT_SOURCE_DIR}/data/LICENSE.furniture")  # of a built-in problem
  install(FILES data/LICENSE.furniture DESTINATION "${CMAKE_INSTALL_DOCDIR}")
endif()
