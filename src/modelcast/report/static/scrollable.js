// What scrolls sideways is reached by Tab, only while it does, and says where more of it is hidden.

const NEARLY_PX = 2;

const watchScrollable = () => {
  const more = (one) => {
    one.toggleAttribute("data-more", one.scrollLeft + one.clientWidth < one.scrollWidth - NEARLY_PX);
  };
  const look = (one) => {
    if (one.scrollWidth > one.clientWidth) {
      one.tabIndex = 0;
      one.setAttribute("role", "group");
      one.setAttribute("aria-label", "Table, scrolls sideways");
    } else ["tabindex", "role", "aria-label"].forEach((name) => one.removeAttribute(name));
    more(one);
  };
  const watching = new ResizeObserver((entries) => entries.forEach(({ target }) => look(target)));
  document.querySelectorAll(".wide, .pst-scrollable-table-container").forEach((one) => {
    look(one);
    watching.observe(one);
    one.addEventListener("scroll", () => more(one), { passive: true });
  });
};

watchScrollable();
