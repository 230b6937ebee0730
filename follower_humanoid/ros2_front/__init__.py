"""The command `ros2` for where ROS 2 is not installed: a small front on rclpy with ros2cli's arguments."""
