"""A humanoid that walks behind the hand that pulls it (Savić et al. 2016), as a ROS 2 package."""
