# SPDX-License-Identifier: Apache-2.0
# ockham_test_again(<target>) : registers the GPU tests of a test program twice more. AddTest.cmake
# calls it. What is left out is named here, with the reason.
#   SwiftShader.<test>, label swiftshader: on a second driver, where test.cmake has unpacked one
#   GpuAssisted.<test>, label gpu_assisted: with instrumented shaders, which report what they do
#     out of bounds; a few tests (EveryKernel, at night, has all kernels)

# Tests that cannot pass on SwiftShader, or take too long.
set(OCKHAM_NOT_ON_SWIFTSHADER
  # It has no push descriptors to compare descriptor sets with.
  ExecutorTest.PushDescriptorsAndSetsAgree
  # A barrier in a kernel costs 20 to 60 times as much there; the small maps remain.
  BucketsTest.LargeMapsAreSortedStablyByCountTileAndRow
  # Its 3D images end at 2048 voxels, and it binds a gigabyte.
  CacheTest.WorkingSetsThatTheDeviceCannotBindAreRefusedWithNumbers
  CacheTest.MarksThatTheDeviceCannotBindAreRefusedWithNumbers
  # Hundreds of kernels, compiled when their pipelines are made: not done after 80 s.
  RandomExecutionTest.* RandomExecutionNightly.*
  # Every method with cheap and stalled shading: a hundred kernels.
  ChartProgramTest.AntiAliasingHasEveryCurveOnATinyPicture
  # Reflection at millions of directions: each takes a minute.
  IsoBsdfTest.DensitiesIntegrateToOneAndAlbedosStayBelowIt
  IsoBsdfTest.SamplesHaveTheirWeightsDensitiesAndDistribution
  # Its memory is files, so that the limit which stands for a full disk ends the process.
  AdaptiveAaProgram.full_disk_is_an_error_and_leaves_nothing
  # It moves corners to sixteenths of a sample: what is drawn is not quite what triangles say.
  VisibilityTest.BothLayoutsSayTheSameOfEverySurface
  VisibilityTest.PlanesPredictTheDepthOfOtherSamples VisibilityTest.PicturesOfBothLayoutsAreAlike
  # Likewise: its floor is not where a lamp's slant is computed for.
  SurfaceVolumeTest.ASlabShadowsAFloorExactly
  # Kernels that hold surfaces and a medium take it some 20 s each; identities and closed forms remain.
  SurfaceVolumeTest.WhereTheMediumIsNotInTheWayMeshesKeepTheirBits SurfaceVolumeTest.A*Furnace*
  SurfaceVolumeTest.OpaqueFogHidesBrightEdgesAtAnyNumberOfSteps
  SurfaceVolumeTest.MeshesKeepTheSunOutOfTheMedium SurfaceVolumeTest.AMovedCameraEqualsAFreshPicture
  SurfaceVolumeTest.IsosurfacesHideMeshesBehindThemAndNoOthers MeshTransportTest.* IsosurfaceSamples.*
  SurfaceVolumeProgram.renders_both_into_one_picture
  # Budgets of loop iterations are lavapipe's need; the same kernels over and over take 40 to 65 s each.
  # VolumeGiTest.TheBudgetOfIterationsChangesNothing remains.
  CacheTest.TheLoopBudgetAndTheBlocksChangeNothing PathTraceTest.BudgetsChangeNoBit*
  # Plans do not depend on the driver.
  AdaptiveAaTest.TheOrderOfDeclarationChangesNoBit VolumeGiTest.TheOrderOfDeclarationChangesNoBit
  # A graph for each size of tiles, 42 s; TheDefaultMetricSeesAcrossTheirBorders remains.
  TilesTest.MakeTheSamePictureBitByBit
  # An access out of bounds ends the process before the layer reads what was found.
  GpuAssistedTest.AccessBeyondABufferIsReported)

# Tests that take SwiftShader 22 to 62 s each, a third of all that it does: at night. Others of their
# programs run the same kernels on it in the default set.
set(OCKHAM_SWIFTSHADER_AT_NIGHT
  VolumeGiProgram.equal_seeds_give_equal_pictures_in_every_mode
  VolumeGiProgram.isovalues_move_from_picture_to_picture
  VolumeGiProgram.resumed_runs_equal_unbroken_ones
  VolumeGiTest.EveryChangeOfTheViewEqualsAFreshPicture
  PathTraceTest.WhiteSurfacesInWhiteMediumAreAFurnace
  PathTraceTest.SlabsReflectAndTransmitAsTheTablesOfAddingAndDoubling
  PathTraceTest.SunlitHalfSpacesHaveChandrasekharsRadiance
  PathTraceTest.HalfSpacesReflectAsTheHFunctionSays
  OckhamMetricsTest.PlanesTakeOneSampleAtAnyAngleDistanceAndScale
  SurfaceVolumeTest.AMeshBehindOrInsideASlabIsDimmedExactly
  BucketsTest.SmallMapsAreSortedStablyByCountTileAndRow
  CoarsenTest.BlocksTakeTheirLargestCountAndCountsTheNextPower)

# Tests of surfaces that together run most of their kernels at a small size.
set(OCKHAM_GPU_ASSISTED
  GpuAssistedTest.* BucketsTest.* GbufferTest.* MetricsTest.* ResolveTest.* SurfaceAovTest.*
  ShadowMapTest.HolesOfAMaskLetTheSunThrough
  AdaptiveAaTest.LoopAndBucketsMakeTheSamePicture SurfaceDepthTest.SolidAtTheStartIsHitThere)

set(OCKHAM_SWIFTSHADER_DIR ${PROJECT_SOURCE_DIR}/build/swiftshader CACHE PATH
  "Folder of vk_swiftshader_icd.json and its library; tests on it are registered if they exist")
set(OCKHAM_SWIFTSHADER_ICD ${OCKHAM_SWIFTSHADER_DIR}/vk_swiftshader_icd.json)
if(OCKHAM_SANITIZE) # which would judge the driver's own machine code
  set(OCKHAM_SWIFTSHADER_ICD "")
elseif(NOT EXISTS ${OCKHAM_SWIFTSHADER_ICD})
  message(STATUS "No ${OCKHAM_SWIFTSHADER_ICD}: no tests with label swiftshader")
  set(OCKHAM_SWIFTSHADER_ICD "")
endif()

# The second driver is the only one that the loader sees.
set(OCKHAM_ON_SWIFTSHADER
  OCKHAM_TEST_GPU=SwiftShader
  VK_DRIVER_FILES=${OCKHAM_SWIFTSHADER_ICD}
  VK_ICD_FILENAMES=${OCKHAM_SWIFTSHADER_ICD}) # loaders older than 1.3.207

# ockham_discover_tests(<target> <name> <labels> <environment> [arguments of gtest_discover_tests...])
# Registers the tests of the target as the list <name>. Labels and environment are lists, which do
# not get through PROPERTIES there. A test may take 300 s, at night an hour.
function(ockham_discover_tests target name labels environment)
  set(timeout 300)
  if("nightly" IN_LIST labels)
    set(timeout 3600)
  endif()
  gtest_discover_tests(${target} DISCOVERY_TIMEOUT 60 TEST_LIST ${name} ${ARGN}
    PROPERTIES TIMEOUT ${timeout})
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${name}.cmake)
  file(WRITE ${file} "if(${name})
  set_tests_properties(\${${name}} PROPERTIES LABELS \"${labels}\" ENVIRONMENT \"${environment}\")
endif()
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${file})
endfunction()

function(ockham_test_again target)
  if(OCKHAM_SWIFTSHADER_ICD)
    list(JOIN OCKHAM_SWIFTSHADER_AT_NIGHT ":" night)
    list(JOIN OCKHAM_NOT_ON_SWIFTSHADER ":" without)
    ockham_discover_tests(${target} ${target}_swiftshader "gpu;swiftshader"
      "${OCKHAM_ON_SWIFTSHADER}" TEST_PREFIX SwiftShader. TEST_FILTER "-${without}:${night}")
    ockham_discover_tests(${target} ${target}_swiftshader_night "gpu;swiftshader;nightly"
      "${OCKHAM_ON_SWIFTSHADER}" TEST_PREFIX SwiftShader. TEST_FILTER "${night}")
  endif()
  list(JOIN OCKHAM_GPU_ASSISTED ":" only)
  ockham_discover_tests(${target} ${target}_gpu_assisted "gpu;gpu_assisted"
    OCKHAM_TEST_VALIDATION=gpu TEST_PREFIX GpuAssisted. TEST_FILTER "${only}")
endfunction()
