"""Map files, read and written (ROS YAML with images, bags, plain images), and atomic writing."""
