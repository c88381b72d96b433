# COIN-OR CBC, which ships no CMake package: target Cbc::Cbc. Debian: coinor-libcbc-dev.
find_path(CBC_INCLUDE_DIR CbcModel.hpp PATH_SUFFIXES coin coin-or)
set(cbc_files "")
set(cbc_needed CBC_INCLUDE_DIR)
foreach(name CbcSolver Cbc Cgl OsiClp Clp Osi CoinUtils)
  find_library(CBC_${name}_LIBRARY ${name})
  mark_as_advanced(CBC_${name}_LIBRARY)
  list(APPEND cbc_files "${CBC_${name}_LIBRARY}")
  list(APPEND cbc_needed CBC_${name}_LIBRARY)
endforeach()
mark_as_advanced(CBC_INCLUDE_DIR)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Cbc REQUIRED_VARS ${cbc_needed})
if(Cbc_FOUND AND NOT TARGET Cbc::Cbc)
  add_library(Cbc::Cbc INTERFACE IMPORTED)
  set_target_properties(Cbc::Cbc PROPERTIES
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${CBC_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${CBC_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${cbc_files}")
endif()
