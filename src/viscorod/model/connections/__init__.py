"""Places on rods and bodies, and what joins or holds them: attachments, joints, springs, supports."""
