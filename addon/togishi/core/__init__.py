"""What the add-on does without Blender: nothing in here imports bpy."""
