# The real command against the real daemon: with the fake worker for everything about jobs, with the real one for what
# a diagnosis prints.
find_program(TENTER_PYTHON3 python3)
if(TARGET tenter AND TENTER_PYTHON3)
  set(cli_programs --tenter $<TARGET_FILE:tenter> --tenterd $<TARGET_FILE:tenterd>
      --data ${PROJECT_SOURCE_DIR}/tests/data)
  add_test(NAME cli_jobs_test COMMAND ${TENTER_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/cli_jobs_test.py
    ${cli_programs} --worker $<TARGET_FILE:tenter-fake-worker>)
  set_tests_properties(cli_jobs_test PROPERTIES TIMEOUT 240 LABELS "e2e" COST 100)  # waits, as in tests/CMakeLists.txt
  if(TARGET tenter-worker)
    add_test(NAME cli_diagnose_test COMMAND ${TENTER_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/cli_diagnose_test.py
      ${cli_programs} --worker $<TARGET_FILE:tenter-worker> --artefacts ${CMAKE_BINARY_DIR}/artefacts/diagnose)
    set_tests_properties(cli_diagnose_test PROPERTIES TIMEOUT 600 LABELS "e2e")
    add_test(NAME cli_simulate_test COMMAND ${TENTER_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/cli_simulate_test.py
      ${cli_programs} --worker $<TARGET_FILE:tenter-worker>)
    set_tests_properties(cli_simulate_test PROPERTIES TIMEOUT 240 LABELS "e2e")
    add_test(NAME cli_sheet_test COMMAND ${TENTER_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/cli_sheet_test.py
      ${cli_programs} --worker $<TARGET_FILE:tenter-worker> --sheets $<TARGET_FILE:tenter-sheet-captures>)
    set_tests_properties(cli_sheet_test PROPERTIES TIMEOUT 240 LABELS "e2e")
    add_test(NAME cli_friction_test COMMAND ${TENTER_PYTHON3} ${CMAKE_CURRENT_SOURCE_DIR}/cli_friction_test.py
      ${cli_programs} --worker $<TARGET_FILE:tenter-worker> --friction-tables $<TARGET_FILE:tenter-twin-friction>)
    set_tests_properties(cli_friction_test PROPERTIES TIMEOUT 240 LABELS "e2e")
  endif()
endif()
