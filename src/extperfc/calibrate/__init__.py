"""Where a camera sits on the robot, from images of a board that moves with the robot (hand-eye calibration).

Two links of the robot are involved: the camera is fixed to one, `parent`, and the board to the other, `carrier`. A
camera on the head that sees a board in the gripper (eye-to-hand) and a camera on the hand that sees a board on the
table (eye-in-hand) are the same problem with other links. For every view i the robot gives parent_T_carrier(i), and
the image gives the corners of the board, which fixes camera_T_board(i). Two transforms are unknown and constant:

    camera_T_board(i) = inverse(parent_T_camera) @ parent_T_carrier(i) @ carrier_T_board

Modules: `board` (what the board looks like, and finding it in an image), `views` (a folder of views), `motions`
(whether the views determine the result, and which motion is missing), `solver` (closed forms, then the joint
refinement), `result` (residuals, uncertainty, files), `drawing` (images of the result), `collector` (the guide of
live collection), `recording` (a bag), `live` (ROS topics), `description` (a URDF with the found pose), `program` (the
command line). Lengths in metres, angles in radians, transforms are 4 x 4 arrays named target_T_source.
"""
