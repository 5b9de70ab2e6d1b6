"""Settings of the analyses: tables of a case file and keyword arguments of the API in one."""
