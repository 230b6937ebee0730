"""Between ROS messages and the samples of the chain; the only place that knows both."""
