# Of the Point Cloud Library only what is used: its own package file would bring VTK and Qt along.
# Targets pcl_common, pcl_kdtree, ... of the COMPONENTS.
find_path(PCL_INCLUDE_DIR pcl/point_types.h PATH_SUFFIXES pcl-1.15 pcl-1.14 pcl-1.13)
find_package(Eigen3 QUIET)
foreach(component IN LISTS PCL_FIND_COMPONENTS)
  find_library(PCL_${component}_LIBRARY pcl_${component})
  mark_as_advanced(PCL_${component}_LIBRARY)
  if(PCL_${component}_LIBRARY AND PCL_INCLUDE_DIR)
    set(PCL_${component}_FOUND TRUE)
    if(NOT TARGET pcl_${component})
      add_library(pcl_${component} UNKNOWN IMPORTED GLOBAL)
      set_target_properties(pcl_${component} PROPERTIES IMPORTED_LOCATION ${PCL_${component}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${PCL_INCLUDE_DIR})
    endif()
  endif()
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(PCL REQUIRED_VARS PCL_INCLUDE_DIR HANDLE_COMPONENTS)
mark_as_advanced(PCL_INCLUDE_DIR)
