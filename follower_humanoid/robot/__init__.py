"""The robot as every node knows it: body table, URDF, Pinocchio model, posture."""
