# SPDX-License-Identifier: Apache-2.0
# ockham_find_volume_readers() : sets, for each of the optional libraries that volumes are read
# with, <name>_FOUND, <name>_INCLUDES (folders) and <name>_FILES (what to link), where <name> is ITK,
# OPENVDB, NANOVDB. Says in one line what is left out, and the packages to install.
# Libraries are named as files, because ITK's targets have no namespace that an installed package
# could find them by.
option(OCKHAM_ITK "Read NRRD, NIfTI, MetaImage and DICOM with ITK, where it is found" ON)
option(OCKHAM_OPENVDB "Read .vdb with OpenVDB, where it is found" ON)
option(OCKHAM_NANOVDB "Read .nvdb with NanoVDB, where it is found" ON)

function(ockham_find_volume_readers)
  set(missing)
  foreach(name ITK OPENVDB NANOVDB)
    set(${name}_FOUND FALSE)
    set(${name}_INCLUDES)
    set(${name}_FILES)
  endforeach()

  if(OCKHAM_ITK)
    set(CMAKE_MESSAGE_LOG_LEVEL ERROR) # GDCM's package reports every program that it lacks
    set(components ITKCommon ITKIOImageBase ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD)
    find_package(ITK 5 QUIET CONFIG COMPONENTS ${components})
    unset(CMAKE_MESSAGE_LOG_LEVEL)
  endif()
  if(ITK_FOUND)
    # Nothing of ITK_USE_FILE: that changes the flags of the directory.
    set(ITK_INCLUDES ${ITK_INCLUDE_DIRS})
    foreach(component IN LISTS components)
      get_target_property(file ${component} LOCATION)
      list(APPEND ITK_FILES ${file})
    endforeach()
  else()
    list(APPEND missing "no .nrrd .nii .mhd .mha and DICOM (libinsighttoolkit5-dev)")
  endif()

  # Debian's FindOpenVDB.cmake stops where Boost's libraries are missing. Its headers want those of
  # Boost, and the libraries TBB and Imath.
  if(OCKHAM_OPENVDB)
    find_path(OPENVDB_INCLUDE openvdb/openvdb.h)
    find_path(OPENVDB_BOOST_INCLUDE boost/numeric/conversion/conversion_traits.hpp)
    find_library(OPENVDB_LIBRARY openvdb)
    find_library(OPENVDB_TBB_LIBRARY tbb)
    mark_as_advanced(OPENVDB_INCLUDE OPENVDB_BOOST_INCLUDE OPENVDB_LIBRARY OPENVDB_TBB_LIBRARY)
    if(OPENVDB_INCLUDE AND OPENVDB_BOOST_INCLUDE AND OPENVDB_LIBRARY AND OPENVDB_TBB_LIBRARY)
      set(OPENVDB_FOUND TRUE)
      set(OPENVDB_INCLUDES ${OPENVDB_INCLUDE} ${OPENVDB_BOOST_INCLUDE})
      set(OPENVDB_FILES ${OPENVDB_LIBRARY} ${OPENVDB_TBB_LIBRARY} Imath::Imath) # came with OpenEXR
    endif()
  endif()
  if(NOT OPENVDB_FOUND)
    list(APPEND missing "no .vdb (libopenvdb-dev libboost-dev)")
  endif()

  if(OCKHAM_NANOVDB)
    find_path(NANOVDB_INCLUDE nanovdb/NanoVDB.h)
    mark_as_advanced(NANOVDB_INCLUDE)
    if(NANOVDB_INCLUDE)
      set(NANOVDB_FOUND TRUE)
      set(NANOVDB_INCLUDES ${NANOVDB_INCLUDE})
    endif()
  endif()
  if(NOT NANOVDB_FOUND)
    list(APPEND missing "no .nvdb (libnanovdb-dev)")
  endif()

  if(missing)
    list(JOIN missing ", " missing)
    message(STATUS "Volumes: ${missing}")
  endif()
  foreach(name ITK OPENVDB NANOVDB)
    foreach(what FOUND INCLUDES FILES)
      set(${name}_${what} ${${name}_${what}} PARENT_SCOPE)
    endforeach()
  endforeach()
endfunction()
