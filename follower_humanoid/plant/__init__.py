"""The plant: world, soles, motors, stops, sensors. What only the simulator knows; free of ROS."""
