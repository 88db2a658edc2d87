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
