"""`helmbench open`: a server on this machine alone, and the page on which logs are dropped and diagnosed."""
