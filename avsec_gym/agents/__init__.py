"""Agents: trained by configurations, kept with cards, judged beside searched baselines."""
