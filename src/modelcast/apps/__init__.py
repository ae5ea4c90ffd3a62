"""Safety applications: pure functions of what a host knows of itself and believes of others."""
