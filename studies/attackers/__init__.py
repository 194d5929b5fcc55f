"""What agents that attack sensors learn, beside baselines that are searched as long."""
