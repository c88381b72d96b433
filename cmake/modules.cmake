# A module is a shared object of this project that is opened when it is first needed, since the library behind it takes long
# to load or may be missing (src/orasp/containers/module_loader.h).
set(orasp_modules orasp_torch orasp_cbc orasp_occt orasp_assimp orasp_nauty orasp_mpi)

# find_module(NAME PACKAGE [ARGUMENTS of find_package]): sets ORASP_NAME to ON or OFF, as ORASP_WITH_NAME asks: ON, OFF, or
# AUTO for where it is found.
macro(find_module name package)
  set(ORASP_${name} OFF)
  if(ORASP_WITH_${name} STREQUAL "AUTO")
    find_package(${package} QUIET ${ARGN})
  elseif(ORASP_WITH_${name})
    find_package(${package} REQUIRED ${ARGN})
  endif()
  if(ORASP_WITH_${name} AND ${package}_FOUND)
    set(ORASP_${name} ON)
  endif()
endmacro()

# find_python_module(): the same for the Python package, which needs a Python with its headers, and pybind11. Debian's Python,
# for which its packages are, is taken unless Python_EXECUTABLE names another one. Not under a sanitizer, which would have to
# be there before Python is.
macro(find_python_module)
  set(ORASP_PYTHON OFF)
  if(ORASP_WITH_PYTHON AND NOT ORASP_SANITIZE)
    if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
      set(Python_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "The Python that the package is built for")
    endif()
    if(ORASP_WITH_PYTHON STREQUAL "AUTO")
      find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
    else()
      find_package(Python 3.9 REQUIRED COMPONENTS Interpreter Development.Module)
    endif()
    if(Python_FOUND)
      set(PYBIND11_FINDPYTHON ON)
      find_module(PYTHON pybind11)
    endif()
  endif()
endmacro()

# add_module(TARGET FILE...): made of these files, which see the library's headers and link none of it.
function(add_module target)
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}" CXX_VISIBILITY_PRESET hidden)
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/src")
endfunction()
