# Finds all external libraries. If one is missing, the error message names the package to install.
function(loomstone_require found what package)
  if(NOT ${found})
    message(FATAL_ERROR "${what} was not found; install it (Debian: apt-get install ${package}).")
  endif()
endfunction()

find_package(Eigen3 3.4 QUIET NO_MODULE)
loomstone_require(Eigen3_FOUND "Eigen 3.4" libeigen3-dev)

find_package(fmt 9 QUIET CONFIG)
loomstone_require(fmt_FOUND "{fmt} 9" libfmt-dev)

find_package(OpenMP QUIET COMPONENTS CXX)
loomstone_require(OpenMP_CXX_FOUND "OpenMP" g++)

find_package(Threads QUIET)
find_package(PkgConfig QUIET)
loomstone_require(PkgConfig_FOUND "pkg-config" pkg-config)

# On Debian 12 CHOLMOD has neither a pkg-config file nor a CMake file.
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
if(NOT CHOLMOD_INCLUDE_DIR OR NOT CHOLMOD_LIBRARY)
  message(FATAL_ERROR "CHOLMOD (SuiteSparse) was not found; install it (Debian: apt-get install libsuitesparse-dev).")
endif()
add_library(loomstone_cholmod INTERFACE)
target_include_directories(loomstone_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(loomstone_cholmod INTERFACE ${CHOLMOD_LIBRARY})

find_path(METIS_INCLUDE_DIR metis.h)
find_library(METIS_LIBRARY metis)
if(NOT METIS_INCLUDE_DIR OR NOT METIS_LIBRARY)
  message(FATAL_ERROR "METIS was not found; install it (Debian: apt-get install libmetis-dev).")
endif()
add_library(loomstone_metis INTERFACE)
target_include_directories(loomstone_metis SYSTEM INTERFACE ${METIS_INCLUDE_DIR})
target_link_libraries(loomstone_metis INTERFACE ${METIS_LIBRARY})

# Selects Bullet in double precision. find_package(Bullet) would find the version in single precision. The package is
# bullet-float64 on Debian. Elsewhere, bullet may be in double precision.
pkg_search_module(BULLET QUIET IMPORTED_TARGET bullet-float64 bullet)
if(NOT "${BULLET_CFLAGS}" MATCHES "BT_USE_DOUBLE_PRECISION")
  set(BULLET_FOUND NO)
endif()
loomstone_require(BULLET_FOUND "Bullet in double precision" "libbullet-dev libbullet-extras-dev")

find_package(embree 3 QUIET CONFIG)
loomstone_require(embree_FOUND "Embree 3" libembree-dev)

# On Debian hdf5-serial is the serial HDF5, and the name hdf5 may refer to the MPI version. Elsewhere there is only hdf5.
pkg_search_module(HDF5 QUIET IMPORTED_TARGET hdf5-serial hdf5)
loomstone_require(HDF5_FOUND "HDF5 (serial)" libhdf5-dev)

find_package(PNG QUIET)
loomstone_require(PNG_FOUND "libpng" libpng-dev)

# MPI is optional. Without it, everything except multiple ranks works.
find_package(MPI QUIET COMPONENTS C)
if(NOT MPI_C_FOUND)
  message(STATUS "MPI was not found: built without the several-ranks plug-in (Debian: apt-get install libopenmpi-dev).")
endif()
