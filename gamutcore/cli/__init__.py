"""The command line ``gamut``: everything that the class `gamutcore.Gamut` does, from a shell.

The modules import the computation when a command runs, so that help and completion are fast. The
package `service` adds the commands of the server to the same program.
"""
