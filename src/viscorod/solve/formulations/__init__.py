"""The element formulations as systems that the analyses assemble."""
