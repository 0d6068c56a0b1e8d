# For other projects: find_package(ch5_backend) and target_link_libraries(… ch5::backend), or pkg-config ch5_backend.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/ch5_backend)
set(postfix $<$<CONFIG:Debug>:d>)  # a debug library and a release one may lie side by side
set_target_properties(ch5_backend PROPERTIES EXPORT_NAME backend DEBUG_POSTFIX d)
set_target_properties(ch5_settings PROPERTIES EXPORT_NAME settings)
write_basic_package_version_file(ch5_backendConfigVersion.cmake COMPATIBILITY SameMajorVersion)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/ch5_backendConfig.cmake [[
include(CMakeFindDependencyMacro)
if(NOT TARGET Eigen3::Eigen)
  find_dependency(Eigen3 3.3 NO_MODULE)
endif()
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/ch5_backendTargets.cmake)
# CMake takes the first where there is none of the program's own build type: not the debug library, unless it is alone.
get_target_property(ch5_configurations ch5::backend IMPORTED_CONFIGURATIONS)
list(SORT ch5_configurations ORDER DESCENDING)
set_target_properties(ch5::backend PROPERTIES IMPORTED_CONFIGURATIONS "${ch5_configurations}")
]])
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME library)  # the others are headers, and tools where programs are built
install(TARGETS ch5_backend ch5_settings EXPORT ch5_backendTargets)
install(EXPORT ch5_backendTargets NAMESPACE ch5:: DESTINATION ${package})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ch5_backendConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/ch5_backendConfigVersion.cmake DESTINATION ${package})
set(documents ${CMAKE_INSTALL_DATAROOTDIR}/doc/libch5-backend-dev)  # named as Debian's package
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${documents} RENAME copyright)

# Paths relative to the file's own place: the prefix is known only at installation.
set(pkgconfig ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH prefix /${pkgconfig} /)
get_target_property(definitions ch5_settings INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM definitions PREPEND -D)
list(JOIN definitions " " definitions)
file(CONFIGURE OUTPUT ch5_backend.pc.in @ONLY CONTENT [[
prefix=${pcfiledir}/@prefix@
libdir=${prefix}/@CMAKE_INSTALL_LIBDIR@
includedir=${prefix}/@CMAKE_INSTALL_INCLUDEDIR@

Name: ch5_backend
Description: @PROJECT_DESCRIPTION@
Version: @PROJECT_VERSION@
Requires: eigen3 >= 3.3
Cflags: -I${includedir} @definitions@
Libs: -L${libdir} -lch5_backend@postfix@ -pthread
]])
set(pc ${CMAKE_CURRENT_BINARY_DIR}/ch5_backend${postfix}.pc)
file(GENERATE OUTPUT ${pc} INPUT ${CMAKE_CURRENT_BINARY_DIR}/ch5_backend.pc.in)
install(FILES ${pc} DESTINATION ${pkgconfig})

# The public headers: those of all layers but for the solver's inside. What one of them includes is public too, as the test
# of the installed library sees.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.h)
list(FILTER headers EXCLUDE REGEX "^(experiments|lab|track|python|open_tasks|dense/blocks|sparse/kernels|sparse/steps|linear/cholmod)/")
foreach(internal IN ITEMS homework_missing math/dense_kernels math/dispatch math/precompiled math/vector_kernels
        linear/conjugate_gradients linear/pivot_rule linear/selected_inverse linear/sparse_cholesky
        sparse/hold_poses sparse/save_hessian sparse/sparse_solver types/edge_curve_fitting)
  if(NOT "${internal}.h" IN_LIST headers)
    message(FATAL_ERROR "install.cmake names ${internal}.h, but there is no such header")
  endif()
  list(REMOVE_ITEM headers ${internal}.h)
endforeach()
foreach(header IN LISTS headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ch5_backend/${folder} COMPONENT headers)
endforeach()

# cpack -G DEB
if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_PACKAGE_NAME libch5-backend-dev)
  set(CPACK_PACKAGE_CONTACT "Authors of the ch5_backend course <ch5-backend@users.noreply.github.com>")
  file(READ ${PROJECT_SOURCE_DIR}/.github/CHANGELOG.md changes)
  string(REGEX MATCH "## ${PROJECT_VERSION} .([0-9-]+)." found "${changes}")
  execute_process(COMMAND date -R -u -d "${CMAKE_MATCH_1}" OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/changelog "libch5-backend-dev (${PROJECT_VERSION}) unstable; urgency=low\n\n"
       "  * Changes: .github/CHANGELOG.md of the project.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  execute_process(COMMAND gzip -9nf ${CMAKE_CURRENT_BINARY_DIR}/changelog)
  # The library lies in lib, not in a folder of each processor's, so its .pc does too.
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/libch5-backend-dev "libch5-backend-dev: pkg-config-unavailable-for-cross-compilation\n")
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/libch5-backend-dev DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/lintian/overrides)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz DESTINATION ${documents} OPTIONAL)
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "nonlinear least squares: bundle adjustment, pose graphs, odometry")
  set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Graphs of residuals over vertices, solved by Levenberg-Marquardt, Dogleg or\n\
Gauss-Newton with sparse Cholesky; marginalization, covariances, and sliding\n\
windows of cameras with an IMU.\n\
For C++17 with Eigen; found by CMake and by pkg-config.")
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
  set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
  set(CPACK_DEBIAN_PACKAGE_DEPENDS "libeigen3-dev (>= 3.3)")
  set(CPACK_STRIP_FILES ON)
  set(CPACK_GENERATOR DEB)
  include(CPack)
endif()
