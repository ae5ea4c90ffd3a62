// Every figure opens in a dialog as wide as it needs: by tap, by Enter, and it closes by Escape.

const LEAST_PX = 1000;

const startEnlarging = () => {
  const figures = [...document.querySelectorAll("figure > img")];
  if (!figures.length) return;
  const dialog = document.createElement("dialog");
  dialog.className = "enlarged";
  const close = document.createElement("button");
  close.type = "button";
  close.textContent = "Close";
  close.addEventListener("click", () => dialog.close());
  const scroller = document.createElement("div");
  scroller.tabIndex = 0;
  scroller.setAttribute("role", "region");
  scroller.setAttribute("aria-label", "Figure, scrolls");
  dialog.append(close, scroller);
  // A tap beside the figure closes too.
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  dialog.addEventListener("close", () => scroller.replaceChildren());
  document.body.append(dialog);
  figures.forEach((image) => {
    const title = image.alt;
    const button = document.createElement("button");
    button.type = "button";
    button.className = "enlarge";
    button.setAttribute("aria-label", `Enlarge: ${title}`);
    button.style.width = image.style.width;
    image.replaceWith(button);
    button.append(image);
    button.addEventListener("click", () => {
      const large = image.cloneNode();
      large.style.width = `max(100%, ${LEAST_PX}px)`;
      scroller.replaceChildren(large);
      dialog.setAttribute("aria-label", title);
      dialog.showModal();
    });
  });
};

startEnlarging();
