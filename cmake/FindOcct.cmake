# OpenCASCADE, what reads STEP files: target Occt::Occt. Its own CMake package wants every part of it, windows included.
# Debian: libocct-data-exchange-dev, libocct-ocaf-dev.
find_path(OCCT_INCLUDE_DIR STEPCAFControl_Reader.hxx PATH_SUFFIXES opencascade)
set(occt_files "")
set(occt_needed OCCT_INCLUDE_DIR)
foreach(name TKXDESTEP TKSTEP TKSTEPBase TKXSBase TKXCAF TKLCAF TKCAF TKCDF TKMesh TKTopAlgo TKBRep TKGeomBase TKG3d TKMath
        TKernel)
  find_library(OCCT_${name}_LIBRARY ${name})
  mark_as_advanced(OCCT_${name}_LIBRARY)
  list(APPEND occt_files "${OCCT_${name}_LIBRARY}")
  list(APPEND occt_needed OCCT_${name}_LIBRARY)
endforeach()
mark_as_advanced(OCCT_INCLUDE_DIR)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Occt REQUIRED_VARS ${occt_needed})
if(Occt_FOUND AND NOT TARGET Occt::Occt)
  add_library(Occt::Occt INTERFACE IMPORTED)
  set_target_properties(Occt::Occt PROPERTIES
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${OCCT_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${OCCT_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${occt_files}")
endif()
