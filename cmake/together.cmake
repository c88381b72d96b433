# compile_together(TARGET FILE...): with ORASP_UNITY, the files are compiled as one, which shares what costs most of a whole
# build (reading headers, instantiating nlohmann's and GoogleTest's templates). Their unnamed namespaces are then one: where
# two files mean different things by a name, rename one or move it to another group. A file in no group is compiled alone.
function(compile_together target)
  if(NOT ORASP_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  list(GET ARGN 0 first)
  string(MAKE_C_IDENTIFIER "${first}" group)
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP "${group}")
endfunction()
