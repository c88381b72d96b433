# Runs an example and compares what it prints with what it should.
#   cmake -DPROGRAM=build/release/examples/example_01_first_plan -DEXPECTED=examples/01_first_plan/expected.txt -P check.cmake
execute_process(COMMAND "${PROGRAM}" OUTPUT_VARIABLE printed ERROR_VARIABLE errors RESULT_VARIABLE code)
file(READ "${EXPECTED}" expected)
if(NOT code EQUAL 0 OR NOT errors STREQUAL "")
  message(FATAL_ERROR "exit code ${code}\n${printed}${errors}")
endif()
if(NOT printed STREQUAL expected)
  message(FATAL_ERROR "it printed\n${printed}\nand should have printed\n${expected}")
endif()
