"""What a run of chapter 5 shows: its answer, tables, plots and pictures."""
