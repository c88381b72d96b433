# A module is a shared object of this project that is opened when it is first needed, since the library behind it takes long
# to load or may be missing (src/orasp/containers/module_loader.h).
set(orasp_modules orasp_torch orasp_cbc orasp_occt orasp_assimp)

# find_module(NAME PACKAGE): sets ORASP_NAME to ON or OFF, as ORASP_WITH_NAME asks: ON, OFF, or AUTO for where it is found.
macro(find_module name package)
  set(ORASP_${name} OFF)
  if(ORASP_WITH_${name} STREQUAL "AUTO")
    find_package(${package} QUIET)
  elseif(ORASP_WITH_${name})
    find_package(${package} REQUIRED)
  endif()
  if(ORASP_WITH_${name} AND ${package}_FOUND)
    set(ORASP_${name} ON)
  endif()
endmacro()

# add_module(TARGET FILE...): made of these files, which see the library's headers and link none of it.
function(add_module target)
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}" CXX_VISIBILITY_PRESET hidden)
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/src")
endfunction()
