"""Supports, joints and held strains in the solvers: rows, multipliers, projections, redundancy, rigid motions."""
