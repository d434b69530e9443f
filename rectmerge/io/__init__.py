"""Map files: ROS YAML with images, bags and plain images, read and written."""
