"""What can be measured on maps: overlap, accuracy, specks, orientation."""
