# A student's lines at work (./course run --mine): ch5_homework, linked once more with the student's files before the
# solutions. Of two definitions the first is taken, and a weak one, which is what own_functions.py makes of a function with
# a blank, only where there is no other.
#
# Optimized a little, since they fly; and each function called by its symbol, so that an unfinished one can be exchanged.
add_library(own_flags INTERFACE)
target_compile_options(own_flags INTERFACE -O1 -g1 -UNDEBUG -D_GLIBCXX_ASSERTIONS ${ch5_filled_stack} -fPIC -fsemantic-interposition)
target_link_libraries(own_flags INTERFACE ch5_settings)
target_include_directories(own_flags INTERFACE ${PROJECT_SOURCE_DIR})

# ch5_add_mine(TARGET FOLDER): the program with the homework of a folder; TARGET.NAME.json tells what came of NAME.cc.
function(ch5_add_mine target folder)
  foreach(file IN LISTS homework_files)
    cmake_path(GET file STEM name)
    if(NOT EXISTS ${folder}/${file})
      set_source_files_properties(${folder}/${file} PROPERTIES GENERATED ON)
    endif()
    set(own ${target}_${name})
    add_library(${own} OBJECT EXCLUDE_FROM_ALL ${folder}/${file})
    target_link_libraries(${own} PRIVATE own_flags)
    set_target_properties(${own} PROPERTIES CXX_COMPILER_LAUNCHER
      "${ch5_python_module};ch5_backend.course.homework.own_functions;${PROJECT_BINARY_DIR}/${target}.${name}.json;${CMAKE_CXX_COMPILER_LAUNCHER}")
    list(APPEND objects $<TARGET_OBJECTS:${own}>)
  endforeach()
  add_executable(${target} EXCLUDE_FROM_ALL ${objects} ${PROJECT_SOURCE_DIR}/ch5_backend/experiments/ch5_homework.cc
    ${ch5_backend_objects})
  target_link_libraries(${target} PRIVATE ch5_studies ch5_warnings)
  target_link_options(${target} PRIVATE LINKER:--allow-multiple-definition)
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
endfunction()

ch5_add_mine(ch5_homework_mine ${CH5_HOMEWORK_DIR})
