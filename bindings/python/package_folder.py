"""The folder of packages below a prefix: package_folder.py PREFIX"""
import os
import site
import sys

prefix = os.path.normpath(sys.argv[1])
searched = [os.path.relpath(folder, prefix) for folder in site.getsitepackages()]
below = [folder for folder in searched if not folder.startswith("..") and (prefix != "/usr" or not folder.startswith("local"))]
print(below[0] if below else f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages")
