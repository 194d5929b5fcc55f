"""Evidence of rays: a surface that another vehicle's rays passed through is not there."""
