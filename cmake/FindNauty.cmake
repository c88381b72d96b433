# nauty (automorphisms of graphs), which ships no CMake package: target Nauty::Nauty. Debian: libnauty2-dev. The shared library,
# since Debian's archive is not position-independent.
find_path(NAUTY_INCLUDE_DIR nauty/nausparse.h)
find_library(NAUTY_LIBRARY NAMES libnauty.so nauty)
mark_as_advanced(NAUTY_INCLUDE_DIR NAUTY_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Nauty REQUIRED_VARS NAUTY_LIBRARY NAUTY_INCLUDE_DIR)
if(Nauty_FOUND AND NOT TARGET Nauty::Nauty)
  add_library(Nauty::Nauty UNKNOWN IMPORTED)
  set_target_properties(Nauty::Nauty PROPERTIES
    IMPORTED_LOCATION "${NAUTY_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${NAUTY_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${NAUTY_INCLUDE_DIR}")
endif()
