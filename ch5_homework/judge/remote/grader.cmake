# What ./course grade compiles submissions with, in its sandbox: build/…/grader has headers, a precompiled header with its
# object, and toolchain.json with the commands; lib has the workers' archives. Nothing of it holds an answer.

# Clang keeps instantiated templates in a precompiled header, which GCC does not, and what they compile to in the header's
# object: so those of usual_expressions.h cost a submission nothing. What Clang refuses is given to the compiler of the
# project, the one that the student has used.
find_program(CH5_CLANG NAMES clang++ clang++-19 clang++-18 clang++-17 clang++-16 clang++-15 clang++-14)
if(NOT CH5_CLANG)
  message(STATUS "No Clang: without ./course grade")
  return()
endif()
set(grader ${PROJECT_BINARY_DIR}/grader)

file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/ch5_backend/*.h)
list(FILTER headers EXCLUDE REGEX "^ch5_backend/(experiments|lab)/")
foreach(header IN LISTS headers ITEMS ch5_homework/judge/told_sizes.h ch5_homework/judge/compiled_products.h
        ch5_homework/judge/in_memory.h ch5_homework/judge/remote/precompiled.h ch5_homework/judge/remote/usual_expressions.h)
  add_custom_command(OUTPUT ${grader}/include/${header} DEPENDS ${PROJECT_SOURCE_DIR}/${header} VERBATIM
    COMMAND ${CMAKE_COMMAND} -E copy ${PROJECT_SOURCE_DIR}/${header} ${grader}/include/${header})
  list(APPEND copies ${grader}/include/${header})
endforeach()
foreach(header IN LISTS earlier_headers)
  configure_file(${earlier}/${header} ${grader}/include/${header} COPYONLY)
endforeach()

get_target_property(eigen Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
get_target_property(alignment ch5_settings INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM alignment PREPEND -D)
set(flags -std=c++17 -O0 -g1 -w -D_GLIBCXX_ASSERTIONS ${alignment} -I${grader}/include -isystem ${eigen})
set(filled -ftrivial-auto-var-init=pattern)  # unset_memory.h
set(precompiled ${grader}/precompiled.pch)
add_custom_command(OUTPUT ${precompiled} DEPENDS ${copies} VERBATIM
  COMMAND ${CH5_CLANG} ${flags} ${filled} -x c++-header ${grader}/include/ch5_homework/judge/remote/usual_expressions.h
          -o ${precompiled} -fpch-instantiate-templates -Xclang -fmodules-codegen)
add_custom_command(OUTPUT ${grader}/precompiled.o DEPENDS ${precompiled} VERBATIM
  COMMAND ${CH5_CLANG} -O0 -c ${precompiled} -o ${grader}/precompiled.o)

# "a;b" as "a", "b".
function(ch5_json_words variable)
  list(TRANSFORM ARGN PREPEND "\"" OUTPUT_VARIABLE words)
  list(TRANSFORM words APPEND "\"")
  list(JOIN words ", " words)
  set(${variable} "${words}" PARENT_SCOPE)
endfunction()
# Constants lie apart from code, in pages that cannot be run: gold, and others on some processors, put both together.
set(apart -Wl,-z,separate-code)
set(quickly_apart ${fast_linker} ${apart})
if(fast_linker MATCHES gold)
  set(quickly_apart ${fast_linker} -Wl,--rosegment)
endif()
file(REAL_PATH ${CH5_CLANG} clang)  # the sandbox has no /etc/alternatives
file(REAL_PATH ${CMAKE_CXX_COMPILER} compiler)
ch5_json_words(quick ${clang} --driver-mode=g++ ${quickly_apart} ${flags} ${filled} -include-pch ${precompiled})
if(NOT CH5_FILLS_THE_STACK)
  set(filled)
endif()
# With the same headers: ch5_homework/judge/student_pch.h gives them to a check.
ch5_json_words(usual ${compiler} ${apart} ${flags} ${filled} -include ${grader}/include/ch5_homework/judge/remote/precompiled.h)
file(CONFIGURE OUTPUT ${grader}/toolchain.json @ONLY CONTENT [=[{
  "include": "@grader@/include",
  "precompiled": ["@grader@/precompiled.pch", "@grader@/precompiled.o"],
  "compile": [[@quick@], [@usual@]],
  "archives": "@PROJECT_BINARY_DIR@/lib",
  "judge": "@PROJECT_BINARY_DIR@/bin/homework_judge"
}
]=])

list(TRANSFORM homework_names PREPEND worker_ OUTPUT_VARIABLE workers)
list(TRANSFORM homework_names PREPEND worker_layers_ OUTPUT_VARIABLE worker_layers)
add_custom_target(homework_grader DEPENDS ${grader}/precompiled.o ${workers} ${worker_layers} homework_judge)
