# libmd (message digests, <sha256.h>): the target md::md. Its archive is preferred to the shared library.
find_library(MD_LIBRARY NAMES libmd.a md)
find_path(MD_INCLUDE_DIR NAMES sha256.h)
mark_as_advanced(MD_LIBRARY MD_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(md REQUIRED_VARS MD_LIBRARY MD_INCLUDE_DIR)
if(md_FOUND AND NOT TARGET md::md)
  add_library(md::md UNKNOWN IMPORTED)
  set_target_properties(md::md PROPERTIES
    IMPORTED_LOCATION "${MD_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${MD_INCLUDE_DIR}"
  )
endif()
