"""Every table, plot and number of the thesis' chapters 3 to 5, beside ours."""
