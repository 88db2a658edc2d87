# The fuzz targets: <name> is test/fuzz/<name>.cpp. Included by test/fuzz (libFuzzer) and by the unit test that runs
# them over their seeds.
set(EXTPERFC_FUZZ_TARGETS convert definition header plan rules xmlrpc)

# extperfc_fuzz_sources(<name> <variable>): the files of a target.
function(extperfc_fuzz_sources name variable)
  set(folder ${PROJECT_SOURCE_DIR}/test/fuzz)
  set(files ${folder}/${name}.cpp ${folder}/require.cpp)
  if(name STREQUAL rules)
    list(APPEND files ${folder}/small_definitions.cpp)
  endif()
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# extperfc_fuzz_links(<name> <variable>): the libraries of a target.
function(extperfc_fuzz_links name variable)
  if(name MATCHES "^(header|xmlrpc)$")
    set(${variable} extperfc::translate_peer PARENT_SCOPE)
  else()
    set(${variable} extperfc::translate_rules PARENT_SCOPE)
  endif()
endfunction()
