"""Laws before the judge: scenarios, evaluation, baselines and their tuning."""
