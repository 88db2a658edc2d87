# ROS 1. Its headers are SYSTEM headers, so their warnings are not ours.
find_package(catkin REQUIRED COMPONENTS
  cv_bridge diagnostic_msgs diagnostic_updater geometry_msgs image_transport message_filters nodelet pluginlib
  roscpp roslib sensor_msgs std_msgs tf2 tf2_eigen tf2_ros vision_msgs visualization_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES extperfc_base extperfc_world extperfc_detect extperfc_depth extperfc_sources
  CATKIN_DEPENDS roscpp nodelet sensor_msgs vision_msgs)

add_library(extperfc_catkin INTERFACE)
target_include_directories(extperfc_catkin SYSTEM INTERFACE ${catkin_INCLUDE_DIRS})
target_link_libraries(extperfc_catkin INTERFACE ${catkin_LIBRARIES})

install(DIRECTORY launch config models urdf tools DESTINATION share/${PROJECT_NAME} USE_SOURCE_PERMISSIONS)
install(DIRECTORY include/extperfc DESTINATION include)
