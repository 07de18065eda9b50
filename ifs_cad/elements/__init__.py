"""What the workshop makes: panels, planks and the labels engraved on them. No CAD kernel here."""
