# The homework as plain CTest tests, for graders without ./course:
#
#   cmake --preset homework && cmake --build --preset homework && ctest --preset homework --output-junit marks.xml
#
# A test for each check, stage_1.1.MakeHessian.OneEdgeBetweenTwoPoses, with the labels homework and stage_1.1. The student's
# file is compiled by a test too, stage_1.1.MakeHessian.compiles: if that fails, only its own stages do, as "Not Run".
file(GLOB stage_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/ch5_homework/judge/stage_*.cc)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${stage_sources})
foreach(source IN LISTS stage_sources)
  file(STRINGS ${source} lines REGEX "^TEST\\(")
  list(APPEND all_checks ${lines})
endforeach()

# ch5_write_homework_tests(FILE PREFIX FOLDER): writes the tests of the executables PREFIXcheck_NAME, made of FOLDER.
list(TRANSFORM ch5_python_module REPLACE "(.+)" "[[\\1]]" OUTPUT_VARIABLE one_check)
list(JOIN one_check " " one_check)
string(APPEND one_check " tests.homework.one_check")
function(ch5_write_homework_tests output prefix folder)
  set(words "")
  foreach(i RANGE ${last_stage})
    foreach(key id name file tests)
      string(JSON ${key} GET "${stages_json}" stages ${i} ${key})
    endforeach()
    cmake_path(GET file STEM stem)
    set(stage stage_${id}.${name})
    set(check ${prefix}check_${stem})
    string(APPEND words "add_test([[${stage}.compiles]] [[${CMAKE_COMMAND}]] --build [[${PROJECT_BINARY_DIR}]] --target ${check})\n"
      "set_tests_properties([[${stage}.compiles]] PROPERTIES FIXTURES_SETUP ${stage} RESOURCE_LOCK ninja TIMEOUT 300 "
      "LABELS [[homework;stage_${id}]])\n")
    string(REPLACE ".*" "" suite ${tests})
    foreach(line IN LISTS all_checks)
      if(line MATCHES "^TEST\\(${suite}, ([A-Za-z0-9]+)\\)")
        set(test ${stage}.${CMAKE_MATCH_1})
        string(APPEND words "add_test([[${test}]] ${one_check} "
          "[[${PROJECT_BINARY_DIR}/bin/${check}]] [[${folder}/${file}]] ${id} ${CMAKE_MATCH_1})\n"
          "set_tests_properties([[${test}]] PROPERTIES FIXTURES_REQUIRED ${stage} TIMEOUT 60 "
          "LABELS [[homework;stage_${id}]])\n")
      endif()
    endforeach()
  endforeach()
  file(GENERATE OUTPUT ${output} CONTENT "${words}")
endfunction()

if(CH5_HOMEWORK_TESTS)
  ch5_write_homework_tests(${PROJECT_BINARY_DIR}/homework_tests.cmake "" ${CH5_HOMEWORK_DIR})
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${PROJECT_BINARY_DIR}/homework_tests.cmake)
endif()

# All that the checks need but the student's files.
list(TRANSFORM homework_files REPLACE "(.*)\\.cc" "stage_tests_\\1" OUTPUT_VARIABLE stage_test_objects)
add_custom_target(homework_ready DEPENDS stage_tests_common ${stage_test_objects} student_pch ch5_backend)

# The same tests of a folder of our own, as a project of CTest's that only plain_ctest.py runs.
ch5_write_homework_tests(${PROJECT_BINARY_DIR}/trial_ctest/CTestTestfile.cmake trial_ ${trial})
ch5_add_python_tests(Homework plain_ctest_test.py LABELS nightly RESOURCE_LOCK ninja TIMEOUT 600)
