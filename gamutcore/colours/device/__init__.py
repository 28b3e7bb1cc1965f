"""Devices: models from device values to colours, ink limits, and points on the device's surface."""
