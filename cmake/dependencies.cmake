# Third-party libraries of the core. A room links only what it owns.
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(tl-expected REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(OpenCV REQUIRED COMPONENTS core imgproc imgcodecs dnn)
find_package(yaml-cpp REQUIRED)
find_package(Threads REQUIRED)
if(EXTPERFC_TESTS)
  find_package(GTest REQUIRED)
endif()

# OpenVINO from PyPI: `tools/setup` puts it into the workspace and names the place.
set(EXTPERFC_OPENVINO_FOUND OFF)
if(EXTPERFC_WITH_OPENVINO)
  find_package(OpenVINO QUIET COMPONENTS Runtime)
  if(OpenVINO_FOUND AND DEFINED OpenVINO_GLIBCXX_USE_CXX11_ABI AND NOT OpenVINO_GLIBCXX_USE_CXX11_ABI)
    message(WARNING "OpenVINO in ${OpenVINO_DIR} is built with the old C++ ABI "
      "(_GLIBCXX_USE_CXX11_ABI=0), which cannot be linked with the system's OpenCV: left out. "
      "Use an OpenVINO archive for this distribution instead of this wheel.")
  elseif(OpenVINO_FOUND)
    set(EXTPERFC_OPENVINO_FOUND ON)
  endif()
endif()
message(STATUS "OpenVINO back end: ${EXTPERFC_OPENVINO_FOUND}")

set(EXTPERFC_MRPT_FOUND OFF)
if(EXTPERFC_WITH_MRPT)
  find_package(mrpt-obs QUIET)
  if(mrpt-obs_FOUND)
    set(EXTPERFC_MRPT_FOUND ON)
  endif()
endif()
message(STATUS "MRPT rawlogs: ${EXTPERFC_MRPT_FOUND}")

# The simulator: robot descriptions, bodies, rays.
find_package(PkgConfig REQUIRED)
pkg_check_modules(urdfdom REQUIRED IMPORTED_TARGET urdfdom)
add_library(extperfc_urdfdom INTERFACE)
add_library(extperfc::urdfdom ALIAS extperfc_urdfdom)
target_link_libraries(extperfc_urdfdom INTERFACE PkgConfig::urdfdom)
pkg_check_modules(bullet REQUIRED IMPORTED_TARGET bullet-float64)
add_library(extperfc_bullet INTERFACE)
add_library(extperfc::bullet ALIAS extperfc_bullet)
target_link_libraries(extperfc_bullet INTERFACE PkgConfig::bullet)

# The translator: XML-RPC is read with tinyxml2.
pkg_check_modules(tinyxml2 REQUIRED IMPORTED_TARGET tinyxml2)
add_library(extperfc_tinyxml2 INTERFACE)
add_library(extperfc::tinyxml2 ALIAS extperfc_tinyxml2)
target_link_libraries(extperfc_tinyxml2 INTERFACE PkgConfig::tinyxml2)

# Embree casts the sensors' rays; a bounding-volume tree of our own stands in for it.
set(EXTPERFC_EMBREE_FOUND OFF)
add_library(extperfc_embree INTERFACE)
add_library(extperfc::embree ALIAS extperfc_embree)
if(EXTPERFC_WITH_EMBREE)
  find_package(embree 3 QUIET)
  if(embree_FOUND)
    set(EXTPERFC_EMBREE_FOUND ON)
    target_link_libraries(extperfc_embree INTERFACE embree)
    target_compile_definitions(extperfc_embree INTERFACE EXTPERFC_EMBREE)
  endif()
endif()
message(STATUS "Embree: ${EXTPERFC_EMBREE_FOUND}")
