"""The live view in the browser, free of ROS: what is seen at one moment, and how it is drawn."""
