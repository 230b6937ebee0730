"""Playing recorded messages back at the pace at which they came, free of ROS."""
