"""Small motions with inputs and outputs: linear systems, and their response to harmonic inputs."""
