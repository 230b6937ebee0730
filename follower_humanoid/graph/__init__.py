"""The wiring of the nodes, and the same chain as one loop without ROS."""
