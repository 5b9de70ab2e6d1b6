"""Places on rods and bodies, and their connections: attachments, joints, springs, supports."""
