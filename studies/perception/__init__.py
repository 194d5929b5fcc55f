"""What the trained networks are worth: precision, disparities, classifiers, and their page."""
