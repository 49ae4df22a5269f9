# SPDX-License-Identifier: Apache-2.0
# cmake -P cmake/demo.cmake : installs what is missing, builds the samples (preset release) and
# renders the built-in atrium with every method of adaptive_aa and built-in volumes with volume_gi.
# Pictures and tables: build/demo/
#   cmake -DSETUP_ONLY=1 -P cmake/demo.cmake    installs and stops
include(${CMAKE_CURRENT_LIST_DIR}/setup.cmake)
if(SETUP_ONLY)
  return()
endif()

set(samples hello_graph adaptive_aa aa_table compare volume_gi surface_volume)
ockham_step(${CMAKE_COMMAND} --preset release)
ockham_step(${CMAKE_COMMAND} --build --preset release --parallel ${cores} --target ${samples})

set(out ${OCKHAM_ROOT}/build/demo)
set(written)
file(MAKE_DIRECTORY ${out})

# On standard output, like what the samples print, so that a log has both in order.
function(say)
  execute_process(COMMAND ${CMAKE_COMMAND} -E echo "${ARGV0}")
endfunction()

function(now_ms result)
  string(TIMESTAMP us "%s%f")
  math(EXPR ms "${us} / 1000")
  set(${result} ${ms} PARENT_SCOPE)
endfunction()

# demo("what it shows" WRITES names... RUN sample arguments...) : runs a sample in build/demo, so
# that names need no folder, shows and keeps what it prints, and stops unless every name was written.
function(demo title)
  cmake_parse_arguments(arg "" "" "WRITES;RUN" ${ARGN})
  list(JOIN arg_RUN " " command)
  list(POP_FRONT arg_RUN sample)
  say("\n== ${title}\n$ ${command}")
  list(TRANSFORM arg_WRITES PREPEND ${out}/ OUTPUT_VARIABLE files)
  file(REMOVE ${files})
  now_ms(start)
  execute_process(COMMAND ${OCKHAM_ROOT}/build/release/bin/${sample} ${arg_RUN}
    WORKING_DIRECTORY ${out} RESULT_VARIABLE result
    OUTPUT_VARIABLE text ECHO_OUTPUT_VARIABLE)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
  now_ms(end)
  foreach(name IN LISTS arg_WRITES)
    if(name MATCHES "\\.txt$")
      file(WRITE ${out}/${name} "${text}")
    elseif(NOT EXISTS ${out}/${name})
      message(FATAL_ERROR "not written: ${out}/${name}")
    endif()
  endforeach()
  math(EXPR tenths "(${end} - ${start} + 50) / 100")
  math(EXPR seconds "${tenths} / 10")
  math(EXPR tenths "${tenths} % 10")
  list(JOIN arg_WRITES ", " names)
  say("${seconds}.${tenths} s for ${names}")
  set(written ${written} ${arg_WRITES} PARENT_SCOPE)
endfunction()

demo("A graph of two passes, its plan and times"
  WRITES hello_graph.txt RUN hello_graph)
demo("Reference: 4 x 4 shaded samples per pixel, linear"
  WRITES atrium_reference.exr RUN adaptive_aa --method ssaa -o atrium_reference.exr)
demo("Reference, for the eye"
  WRITES atrium_reference.png RUN adaptive_aa --method ssaa -o atrium_reference.png)
demo("No anti-aliasing: 1 shaded sample per pixel"
  WRITES atrium_none.png atrium_none.json
  RUN adaptive_aa --method none -o atrium_none.png
    --reference atrium_reference.exr --stats atrium_none.json)
demo("Adaptive: as many shaded samples as each pixel needs, and how many those are"
  WRITES atrium_adaptive.png atrium_k.png atrium_adaptive.json
  RUN adaptive_aa -o atrium_adaptive.png --capture sample_count=atrium_k.png
    --reference atrium_reference.exr --stats atrium_adaptive.json)
demo("Adaptive against reference; error x 10"
  WRITES atrium_error_x10.png atrium_side_by_side.png atrium_compare.txt
  RUN compare atrium_adaptive.png atrium_reference.png --scale 10
    --error-map atrium_error_x10.png --side-by-side atrium_side_by_side.png)
demo("Cost and error of every method; a quarter of the pixels, for it renders each 8 times"
  WRITES aa_table.md aa_table.csv RUN aa_table --width 512 --height 384 --out aa_table)

demo("A cloud: light followed through every scattering, 16 paths per pixel"
  WRITES cloud.png cloud.json
  RUN volume_gi --width 320 --height 240 --steps 16 --camera "0.8,-1.7,0.1 0,0,-0.05 30"
    -o cloud.png --stats cloud.json)
demo("Shells of 1 to 8 voxels, cut open: surfaces are met exactly, however thin"
  WRITES shells.png
  RUN volume_gi builtin:shells --iso 100 --density-scale 0 --crop 0,1,0.5,1,0,1 --width 320
    --height 240 --steps 16 --camera "0.7,-1.9,0.8 0,0,0 30" -o shells.png)
demo("The shells as fog, from three sides that share the light in a cache"
  WRITES shells_turn0.png shells_turn1.png shells_turn2.png
  RUN volume_gi builtin:shells --mode caching --gather off --cache-scale 4 --density-scale 20
    --width 320 --height 240 --steps 16 --camera "0.7,-1.9,0.8 0,0,0 30" --turntable 3
    -o shells_turn%d.png)

demo("A cloud among meshes: each shadows the other, in one graph"
  WRITES atrium_cloud.png
  RUN surface_volume builtin:atrium builtin:cloud --lights 1 --place "-4.5,2.6,0.4 0,0,0 4"
    --density-scale 4 --mode caching --gather off --cache-scale 4 --width 320 --height 240
    -o atrium_cloud.png)

say("\nLook in ${out}:")
foreach(name IN LISTS written)
  file(SIZE ${out}/${name} bytes)
  math(EXPR kib "(${bytes} + 1023) / 1024")
  say("  ${name} (${kib} KiB)")
endforeach()
