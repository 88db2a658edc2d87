include(cmake/interfaces.cmake)

# ROS 1. Its headers are SYSTEM headers, so their warnings are not ours.
find_package(catkin REQUIRED COMPONENTS
  actionlib baxter_core_msgs control_msgs cv_bridge diagnostic_msgs diagnostic_updater dynamic_reconfigure geometry_msgs image_transport
  map_msgs message_filters message_generation move_base_msgs nav_msgs nodelet pluginlib roscpp rosgraph_msgs roslib sensor_msgs shape_msgs std_msgs std_srvs
  tf2 tf2_eigen tf2_ros trajectory_msgs vision_msgs visualization_msgs)

catkin_python_setup()
add_message_files(FILES ArmCode.msg ArmRequest.msg Face.msg FaceArray.msg SceneObject.msg ToolConstraint.msg ToolGoal.msg Track.msg
  NavCode.msg NavigationStatus.msg TrackArray.msg)
add_service_files(FILES
  ApplyScene.srv CheckArmState.srv DetectOnce.srv EnrollFace.srv ForgetFace.srv GetScene.srv LoadSession.srv MoveBody.srv ObjectCloud.srv SaveMap.srv SetFault.srv
  SetRealTimeFactor.srv SolveArmIk.srv StepSimulation.srv)
add_action_files(FILES Explore.action FollowWaypoints.action MoveArm.action Pick.action Place.action Plan.action)
generate_messages(DEPENDENCIES actionlib_msgs geometry_msgs sensor_msgs shape_msgs std_msgs trajectory_msgs vision_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES extperfc_base extperfc_world extperfc_detect extperfc_face extperfc_depth extperfc_track extperfc_sources extperfc_scan
    extperfc_robot_model extperfc_simulate_worlds extperfc_simulate_render extperfc_simulate_bodies
    extperfc_simulate_control extperfc_simulate_trajectory extperfc_translate_schema extperfc_translate_plan
    extperfc_translate_rules extperfc_translate_peer extperfc_translate_bridge extperfc_mapping extperfc_localize
    extperfc_sources_scan extperfc_offline extperfc_arm_kinematics extperfc_arm_collision
    extperfc_arm_planning extperfc_arm_trajectory extperfc_arm_constrained extperfc_arm_cartesian
    extperfc_arm_grasping extperfc_arm_perception extperfc_arm_motion extperfc_navigate_costs extperfc_navigate_global
    extperfc_navigate_local extperfc_navigate
  CATKIN_DEPENDS roscpp nodelet message_runtime sensor_msgs vision_msgs)

add_library(extperfc_catkin INTERFACE)
target_include_directories(extperfc_catkin SYSTEM INTERFACE ${catkin_INCLUDE_DIRS} ${CATKIN_DEVEL_PREFIX}/include)
target_link_libraries(extperfc_catkin INTERFACE ${catkin_LIBRARIES})

install(DIRECTORY launch config models urdf DESTINATION share/${PROJECT_NAME})
# Without what works on a checkout alone.
install(DIRECTORY tools DESTINATION share/${PROJECT_NAME} USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE
  REGEX "/tools/(bench|demo|fuzz|setup|soak_translator|test)$" EXCLUDE
  REGEX "/lib/(debian.*|demo.*|soak_.*|run_.*|tidy)[.](py|txt)$" EXCLUDE)
install(DIRECTORY include/extperfc DESTINATION include)
