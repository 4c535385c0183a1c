# SPDX-License-Identifier: Apache-2.0
# cmake --install, and the package for find_package(vesta) (vestaConfig.cmake.in). The same with VESTA_CUDA, because
# device code is in separate libraries that are not installed.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/vesta)

install(TARGETS vesta_core vesta_ranks vesta_solver vesta_distributed vesta_toy vesta_bundle_adjustment vesta_pose_graph
  EXPORT vesta)
install(EXPORT vesta NAMESPACE vesta:: FILE vestaTargets.cmake DESTINATION ${package_dir})
# A separate export set, so that only users of the bridge need Ceres.
if(TARGET vesta_ceres_bridge)
  set_target_properties(vesta_ceres_functors PROPERTIES EXPORT_NAME ceres_functors)
  install(TARGETS vesta_ceres_bridge vesta_ceres_functors EXPORT vesta_ceres)
  install(EXPORT vesta_ceres NAMESPACE vesta:: FILE vestaCeresTargets.cmake DESTINATION ${package_dir})
endif()
# The same for MPI.
if(TARGET vesta_mpi)
  install(TARGETS vesta_mpi EXPORT vesta_mpi)
  install(EXPORT vesta_mpi NAMESPACE vesta:: FILE vestaMpiTargets.cmake DESTINATION ${package_dir})
endif()
if(TARGET vesta)
  install(TARGETS vesta COMPONENT program)
  include(${CMAKE_CURRENT_LIST_DIR}/Manual.cmake)
endif()

# Patterns of the public headers. All headers that they include are installed too.
set(headers kernels/core/*.h kernels/ranks/*.h kernels/math/double_lanes.h kernels/math/quaternion.h solver/*.h solver/distributed/*.h
  problems/toy/*.h problems/bundle_adjustment/bal_file.h
  problems/bundle_adjustment/bundle_parts.h problems/bundle_adjustment/bundle_problem.h
  problems/pose_graph/certificate.h problems/pose_graph/chordal.h problems/pose_graph/closure_check.h
  problems/pose_graph/g2o_file.h problems/pose_graph/pose_graph_problem.h problems/pose_graph/poses.h
  problems/pose_graph/robust.h problems/pose_graph/solve.h)
if(TARGET vesta_mpi)
  list(APPEND headers kernels/mpi/*.h)
endif()
if(TARGET vesta_ceres_bridge)
  list(APPEND headers solver/ceres/*.h)
endif()
install(CODE "set(headers \"${headers}\")
  set(source_dir \"${PROJECT_SOURCE_DIR}\")
  set(include_dir \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/vesta\")")
install(SCRIPT ${CMAKE_CURRENT_LIST_DIR}/InstallHeaders.cmake)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/vestaConfig.cmake.in ${PROJECT_BINARY_DIR}/vestaConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/vestaConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/vestaConfig.cmake ${PROJECT_BINARY_DIR}/vestaConfigVersion.cmake
  DESTINATION ${package_dir})
if(TARGET vesta)
  include(${CMAKE_CURRENT_LIST_DIR}/Package.cmake)
endif()
